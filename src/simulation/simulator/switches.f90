!> Error sources of a simulation, switched off one by one: CSR-TM-00-01 section 6.3.
module gracecg_simulation_switches
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: join
    use gracecg_files_value, only: did_you_mean
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    implicit none
    private
    public :: error_switches_t, new_switched_simulator, switch_off, SOURCE_NAMES

    !> The error sources that act. The estimator knows nothing of the switches: its weights stay.
    type :: error_switches_t
        logical :: curved_force = .true.
        !! The non-gravitational acceleration is not linear in time, and the density wave acts
        logical :: accelerometer_noise = .true.     !! Coloured noise of the accelerometer
        logical :: star_camera_noise = .true.       !! Noise of stars and catalogue
        logical :: magnetometer_noise = .true.      !! White noise and resolution of the magnetometer
        logical :: magnetometer_bias = .true.       !! Constant error of the magnetometer
        logical :: scale_factors = .true.           !! The accelerometer's, linear to cubic
    end type error_switches_t

    character(19), parameter :: SOURCE_NAMES(7) = [character(19) :: 'curved-force', 'accelerometer-noise', &
        'star-camera-noise', 'magnetometer-noise', 'magnetometer-bias', 'scale-factors', 'systematic']
    !! What can be switched off by name; systematic stands for curved-force, magnetometer-bias and
    !! scale-factors together

contains

    !> Switches off a source by its name. Fails for a name that is none of SOURCE_NAMES.
    subroutine switch_off(switches, name, error)
        type(error_switches_t), intent(inout) :: switches
        character(*), intent(in) :: name    !! Of the source
        type(error_t), allocatable, intent(out) :: error

        if (.not. any(SOURCE_NAMES == name)) then
            call fail(error, 'no error source "'//name//'"; there are '//join(SOURCE_NAMES, ', ')// &
                      did_you_mean(name, SOURCE_NAMES))
            return
        end if
        associate (systematic => name == 'systematic')
            if (name == 'curved-force' .or. systematic) switches%curved_force = .false.
            if (name == 'accelerometer-noise') switches%accelerometer_noise = .false.
            if (name == 'star-camera-noise') switches%star_camera_noise = .false.
            if (name == 'magnetometer-noise') switches%magnetometer_noise = .false.
            if (name == 'magnetometer-bias' .or. systematic) switches%magnetometer_bias = .false.
            if (name == 'scale-factors' .or. systematic) switches%scale_factors = .false.
        end associate
    end subroutine switch_off

    !> The simulator of a case in which only the error sources that are switched on act. Fails as
    !> `new_simulator` does.
    subroutine new_switched_simulator(case, switches, simulator, error)
        type(case_t), intent(in) :: case
        type(error_switches_t), intent(in) :: switches
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable, intent(out) :: error

        type(case_t) :: switched

        switched = case
        if (.not. switches%accelerometer_noise) switched%satellite%accelerometer%noise%level = 0
        if (.not. switches%star_camera_noise) then
            switched%satellite%star_camera%catalogue_noise = 0
            switched%satellite%star_camera%measurement_noise = 0
        end if
        if (.not. switches%magnetometer_noise) switched%satellite%magnetometer%noise = 0
        if (.not. switches%magnetometer_bias) switched%satellite%magnetometer%bias = 0
        if (.not. switches%scale_factors) then
            switched%satellite%accelerometer%scale1 = 1
            switched%satellite%accelerometer%scale2 = 0
            switched%satellite%accelerometer%scale3 = 0
        end if
        call new_simulator(switched, simulator, error)
        if (allocated(error) .or. switches%curved_force) return
        call straighten_force(simulator%arc)
        simulator%case%density_wave_random = .false.
    end subroutine new_switched_simulator

    !> Replaces the non-gravitational acceleration along an arc by its linear fit (least squares).
    !> Orbit and attitude stay.
    pure subroutine straighten_force(arc)
        type(truth_arc_t), intent(inout) :: arc

        real(dp) :: mean(3), slope(3), centred
        integer :: k

        mean = 0
        slope = 0
        do k = 0, arc%steps
            associate (acting => arc%loads(k))
                mean = mean + (acting%drag + acting%srp + acting%erp)/(arc%steps + 1)
            end associate
        end do
        do k = 0, arc%steps
            centred = k - arc%steps/2.0_dp
            associate (acting => arc%loads(k))
                slope = slope + centred*(acting%drag + acting%srp + acting%erp - mean)
            end associate
        end do
        ! sum of the squares of n + 1 equally spaced numbers about their mean
        slope = slope*12/(arc%steps*(arc%steps + 1.0_dp)*(arc%steps + 2.0_dp))
        do k = 0, arc%steps
            arc%loads(k)%drag = mean + slope*(k - arc%steps/2.0_dp)
            arc%loads(k)%srp = 0
            arc%loads(k)%erp = 0
        end do
    end subroutine straighten_force
end module gracecg_simulation_switches
