!> The planner: how good manoeuvres are at a place, against the published facts of the covariance
!> analysis and against the simulation; the search and its guarantees.
module test_design
    use gracecg_kinds, only: dp
    use gracecg_constants, only: DEGREE, PI
    use gracecg_error, only: error_t, message_of
    use gracecg_torque_rods
    use gracecg_equations_of_motion, only: OMEGA
    use gracecg_truth_arc, only: truth_arc_t
    use gracecg_calibration_case, only: calibration_case_t
    use gracecg_report_cases, only: report_case, REPORT_CASE_NAMES
    use gracecg_simulation, only: propagate_case
    use gracecg_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_manoeuvre_site
    use gracecg_manoeuvre_design
    use fixture, only: check_fails, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_design

contains

    subroutine collect_design(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('facts-of-the-covariance-analysis', test_facts), &
                    new_unittest('try', test_try)]
    end subroutine collect_design

    !> View and start of a case.
    subroutine stand(case, view, site, error)
        type(calibration_case_t), intent(in) :: case
        type(accelerometer_view_t), intent(out) :: view
        type(manoeuvre_site_t), intent(out) :: site
        type(error_type), allocatable, intent(out) :: error

        type(nominal_orbit_t) :: orbit
        type(error_t), allocatable :: failure

        call new_accelerometer_view(case, view, failure)
        if (.not. allocated(failure)) call new_nominal_orbit(case, orbit, failure, interval=10.0_dp)
        if (.not. allocated(failure)) call new_manoeuvre_site(view, orbit, 0.0_dp, site, failure)
        call check_passes(error, message_of(failure))
    end subroutine stand

    !> Independent covariance analysis, one-sided noise, 60 s, 30 A m^2 a rod, micrometres as printed:
    !> the report's manoeuvre; y sine and z cosine at 0.1 Hz; x, y, z at 5, 6, 7 cycles.
    subroutine test_facts(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp), parameter :: FACTS(3, 3, 3) = reshape([ &
            84.0_dp, 32.0_dp, 30.0_dp, 6.6_dp, 3.0_dp, 6.3_dp, 6.2_dp, 3.0_dp, 5.9_dp, &
            777.0_dp, 1.6_dp, 9.3_dp, 62.0_dp, 0.9_dp, 9.2_dp, 3.3_dp, 0.7_dp, 3.1_dp, &
            8.8_dp, 25.0_dp, 22.0_dp, 5.3_dp, 5.6_dp, 5.1_dp, 5.3_dp, 5.6_dp, 5.1_dp], [3, 3, 3])
        type(calibration_case_t) :: case
        type(accelerometer_view_t) :: view
        type(manoeuvre_site_t) :: site
        type(manoeuvre_quality_t) :: quality
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        integer :: number, manoeuvre, axis
        integer :: cycle_count(3)

        do number = 1, 3
            call report_case(REPORT_CASE_NAMES(number), case, failure)
            case%accelerometer%noise_sides = 1
            call stand(case, view, site, error)
            if (allocated(error)) return
            do manoeuvre = 1, 3
                select case (manoeuvre)
                case (1)
                    rods = case%setup%rods
                case (2)
                    call new_torque_rods(rods, [ &
                                         rod_activation_t(2, 30.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp), &
                                         rod_activation_t(3, 30.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp, COSINE)], &
                                         failure)
                case (3)
                    cycle_count = [5, 6, 7]
                    call new_torque_rods(rods, [(rod_activation_t(axis, 30.0_dp, cycle_count(axis)/60.0_dp, &
                                                                 0.0_dp, 0.0_dp, 60.0_dp), axis=1, 3)], failure)
                end select
                call evaluate_manoeuvre(view, site, rods, quality)
                print *, number, manoeuvre, &
                 quality%sigma*1e6_dp, FACTS(:, manoeuvre, number), quality%wave*1e6, &
                  quality%motion%rate/DEGREE, quality%motion%excursion/DEGREE
            end do
        end do
    end subroutine test_facts

    subroutine test_try(error)
        use omp_lib
        type(error_type), allocatable, intent(out) :: error
        type(calibration_case_t) :: case
        type(accelerometer_view_t) :: view
        type(manoeuvre_site_t) :: site(1)
        type(manoeuvre_design_t) :: design
        type(design_settings_t) :: settings
        type(error_t), allocatable :: failure
        real(dp) :: t0
        integer :: number, w, k

        do number = 1, 3
            call report_case(REPORT_CASE_NAMES(number), case, failure)
            call stand(case, view, site(1), error)
            do w = 1, 4
                settings%waveform_used = .false.
                settings%waveform_used(w) = .true.
                t0 = omp_get_wtime()
                call design_manoeuvre(view, site, settings, design, failure)
                if (allocated(failure)) print *, failure%message
                print '(i2,1x,a,f8.2,i8,3f8.2,2x,3f8.2,2x,f8.2,2f8.3)', number, WAVEFORM_NAMES(w), omp_get_wtime()-t0, &
                    design%evaluations, design%sigma*1e6, design%wave*1e6, design%worst*1e6, design%rate/DEGREE, &
                    design%excursion/DEGREE
                print '(20x,3(2f9.3,3x))', (design%rods%activations(k)%frequency*60, &
                  design%rods%activations(k)%phase/DEGREE, k=1,3)
            end do
        end do
    end subroutine
end module test_design
