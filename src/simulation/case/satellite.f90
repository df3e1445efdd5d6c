!> The satellite as it really is: the truth of a simulation. What its operator believes of it is derived in
!> gracecg_simulation_case_models.
module gracecg_simulation_satellite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, ARCSECOND, NANOTESLA
    use gracecg_files_settings, only: settings_t
    use gracecg_spacecraft_plates, only: REPORT_PRISM
    use gracecg_spacecraft_surface_loads, only: wall_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_observations_accelerometer_line, only: accelerometer_line_t
    use gracecg_observations_noise_table, only: describe_noise_spectra
    use gracecg_simulation_accelerometer, only: accelerometer_t
    use gracecg_simulation_star_camera, only: star_camera_t, STAR_SELECTIONS
    use gracecg_simulation_magnetometer, only: magnetometer_t
    implicit none
    private
    public :: satellite_t, describe_surface, describe_accelerometer, describe_star_camera, describe_magnetometer

    !> A satellite with its instruments. The defaults are the values of CSR-TM-00-01 section 5.2 as printed.
    type :: satellite_t
        character(16) :: name = 'front'             !! Of the pair: 'front' or 'back'
        real(dp) :: mass = 0                        !! kg
        real(dp) :: inertia(3, 3) = 0               !! J_p about the proof-mass centre, kg m^2
        real(dp) :: offset(3) = 0                   !! d, from COM to proof-mass centre, body axes, m
        type(torque_rods_t) :: rods                 !! As they are, and what they are commanded to
        ! surface
        real(dp) :: length = REPORT_PRISM(1), height = REPORT_PRISM(2)              !! m
        real(dp) :: width_bottom = REPORT_PRISM(3), width_top = REPORT_PRISM(4)     !! m
        real(dp) :: centre_of_mass(3) = 0           !! In the trapezoid's frame, m
        character(16) :: forces = 'report'
        !! What air and light accelerate it by: 'report', (2-6) to (2-10), or 'plates', the loads of its torques
        real(dp) :: drag_coefficient = 2.0_dp       !! C_d of (2-6)
        type(wall_t) :: wall                        !! For the air plate by plate
        real(dp) :: specular = 0, diffuse = 0       !! Of all plates, for light plate by plate
        real(dp) :: reflectivity_sun = 0.45_dp      !! eta of (2-8)
        real(dp) :: reflectivity_earth = 0.5_dp     !! eta_e of (2-10)
        ! instruments
        type(accelerometer_t) :: accelerometer      !! Noise, scale factors and biases
        type(accelerometer_line_t) :: line          !! Where there are several such
        type(star_camera_t) :: star_camera          !! Heads with their mounting, field of view and noise
        type(magnetometer_t) :: magnetometer        !! Noise and bias
    contains
        procedure :: place                          !! Of the pair: names random numbers
    end type satellite_t

contains

    !> 1 of the front satellite, 2 of the back one.
    pure integer function place(self)
        class(satellite_t), intent(in) :: self

        place = merge(1, 2, self%name == 'front')
    end function place

    !> Shape and surface: group surface.
    subroutine describe_surface(settings, satellite)
        class(settings_t), intent(inout) :: settings
        type(satellite_t), intent(inout) :: satellite

        call settings%group('surface', 'Shape and surface of the satellite')
        call settings%real_value('length', satellite%length, 1e-3_dp, 100.0_dp, 'm, of the trapezoidal prism', &
                                 unit='m')
        call settings%real_value('height', satellite%height, 1e-3_dp, 100.0_dp, 'm', unit='m')
        call settings%real_value('width_bottom', satellite%width_bottom, 1e-3_dp, 100.0_dp, 'm', unit='m')
        call settings%real_value('width_top', satellite%width_top, 1e-3_dp, 100.0_dp, 'm', unit='m')
        call settings%real_values('centre_of_mass', satellite%centre_of_mass, -100.0_dp, 100.0_dp, &
                                  'm, from the middle of the prism, body axes', unit='m')
        call settings%text_value('forces', satellite%forces, 'accelerations by (2-6) to (2-10), or plate by plate '// &
                                 'as the torques', [character(16) :: 'report', 'plates'])
        call settings%real_value('drag_coefficient', satellite%drag_coefficient, 0.0_dp, 10.0_dp, 'of the drag')
        call settings%real_value('wall_temperature', satellite%wall%temperature, 0.0_dp, 3000.0_dp, &
                                 'K, for the aerodynamic torque', unit='K')
        call settings%real_value('accommodation', satellite%wall%accommodation, 0.0_dp, 1.0_dp, &
                                 'of energy, for the aerodynamic torque')
        call settings%real_value('specular', satellite%specular, 0.0_dp, 1.0_dp, &
                                 'reflectivity, for the torque of sunlight')
        call settings%real_value('diffuse', satellite%diffuse, 0.0_dp, 1.0_dp, &
                                 'reflectivity, for the torque of sunlight')
        if (satellite%specular + satellite%diffuse > 1) then
            call settings%reject('diffuse', 'and specular together exceed 1')
        end if
        call settings%end_group()
    end subroutine describe_surface

    !> Group accelerometer.
    subroutine describe_accelerometer(settings, accelerometer)
        class(settings_t), intent(inout) :: settings
        type(accelerometer_t), intent(inout) :: accelerometer

        call settings%group('accelerometer', 'Accelerometer: scale1 a + scale2 a^2 + scale3 a^3 + bias + '// &
                            'noise of spectrum level (1 + corner/f), or of a table')
        call settings%real_values('scale1', accelerometer%scale1, -10.0_dp, 10.0_dp, 'x, y, z')
        call settings%real_values('scale2', accelerometer%scale2, -1e6_dp, 1e6_dp, 's^2/m', unit='s^2/m')
        call settings%real_values('scale3', accelerometer%scale3, -1e9_dp, 1e9_dp, 's^4/m^2', &
                                  unit='s^4/m^2')
        call settings%real_values('bias', accelerometer%bias, -1.0_dp, 1.0_dp, 'm/s^2', unit='m/s^2')
        call describe_noise_spectra(settings, accelerometer%noise)
        call settings%real_value('interval', accelerometer%sampling_interval, 1e-3_dp, 10.0_dp, &
                                 's, between samples', unit='s')
        call settings%logical_value('limited', accelerometer%limited, 'samples saturate at the range')
        call settings%real_value('range', accelerometer%range, 1e-9_dp, 1.0_dp, 'm/s^2, full scale', unit='m/s^2')
        call settings%logical_value('quantised', accelerometer%quantised, 'samples are rounded')
        call settings%real_value('resolution', accelerometer%resolution, 1e-15_dp, 1.0_dp, 'm/s^2', unit='m/s^2')
        call settings%end_group()
    end subroutine describe_accelerometer

    !> Group star_camera.
    subroutine describe_star_camera(settings, camera, catalogue_file, head)
        class(settings_t), intent(inout) :: settings
        type(star_camera_t), intent(inout) :: camera
        character(*), intent(inout) :: catalogue_file   !! Of the stars; empty: the embedded catalogue
        integer, intent(inout) :: head                  !! Whose quaternions the operator uses

        call settings%group('star_camera', 'Star camera: two heads in the body y-z plane')
        call settings%real_values('elevation_deg', camera%elevation, 0.0_dp, 180.0_dp, &
                                  'deg, of the boresights, from +y over the zenith', DEGREE, 'deg')
        call settings%real_values('field_of_view_deg', camera%field_of_view, 0.1_dp, 170.0_dp, &
                                  'deg, along camera x and y', DEGREE, 'deg')
        call settings%integer_value('stars', camera%star_count, 2, 70, 'used of a frame')
        call settings%text_value('selection', camera%selection, 'which: the first of the catalogue, or the best', &
                                 STAR_SELECTIONS)
        call settings%real_value('catalogue_noise_arcsec', camera%catalogue_noise, 0.0_dp, 3600.0_dp, &
                                 'arcsec', ARCSECOND, 'arcsec')
        call settings%real_value('measurement_noise_arcsec', camera%measurement_noise, 0.0_dp, 3600.0_dp, &
                                 'arcsec', ARCSECOND, 'arcsec')
        call settings%text_value('catalogue_file', catalogue_file, 'empty: the built-in catalogue')
        call settings%real_value('interval', camera%sampling_interval, 1e-3_dp, 100.0_dp, 's', &
                                 unit='s')
        call settings%integer_value('head', head, 1, 2, 'whose quaternions are used')
        call settings%end_group()
    end subroutine describe_star_camera

    !> Group magnetometer.
    subroutine describe_magnetometer(settings, magnetometer)
        class(settings_t), intent(inout) :: settings
        type(magnetometer_t), intent(inout) :: magnetometer

        call settings%group('magnetometer', 'Magnetometer')
        call settings%real_values('bias_nt', magnetometer%bias, -1e9_dp, 1e9_dp, 'nT', NANOTESLA, 'nT')
        call settings%real_value('noise_nt', magnetometer%noise, 0.0_dp, 1e9_dp, 'nT', NANOTESLA, 'nT')
        call settings%logical_value('limited', magnetometer%limited, 'samples saturate at the range')
        call settings%real_value('range_nt', magnetometer%range, 1.0_dp, 1e9_dp, 'nT', NANOTESLA, 'nT')
        call settings%logical_value('quantised', magnetometer%quantised, 'samples are rounded')
        call settings%real_value('resolution_nt', magnetometer%resolution, 1e-6_dp, 1e9_dp, 'nT', NANOTESLA, &
                                 'nT')
        call settings%real_value('linearity_nt', magnetometer%linearity, 0.0_dp, 1e9_dp, &
                                 'nT, greatest departure from a straight line', NANOTESLA, 'nT')
        call settings%real_value('bandwidth_hz', magnetometer%bandwidth, 0.0_dp, 1e6_dp, &
                                 'Hz, corner of a low-pass filter; 0: none', unit='Hz')
        call settings%real_value('interval', magnetometer%sampling_interval, 1e-3_dp, 100.0_dp, 's', &
                                 unit='s')
        call settings%end_group()
    end subroutine describe_magnetometer
end module gracecg_simulation_satellite
