!> What the comparison with the axis windows of Figures 5.2-5.8 can see: case 1 of both satellites with one setting
!> changed at a time, and how many windows each change still meets.
module gracecg_studies_window_sensitivity
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_files_data_table, only: data_table_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case, SATELLITES
    use gracecg_studies_curves, only: verification_t, verify_case, window_check_t, check_windows, window_counts_t, &
        count_windows
    implicit none
    private
    public :: variation_t, study_window_sensitivity, variations_table, VARIATIONS

    integer, parameter :: VARIATIONS = 14           !! The first is the case as it is

    !> One change, and the windows that it meets in both satellites.
    type :: variation_t
        character(32) :: name = ''                  !! What is changed
        real(dp) :: amplitude = 1, frequency = 1    !! Factors of those of the rods
        real(dp) :: first_rod = 1, second_rod = 1   !! Factors of the moment of one rod; -1: reversed; 0: off
        real(dp) :: offset(3) = 1                   !! Factors of the components of d
        type(window_counts_t) :: counts = window_counts_t()     !! Of front-1 and back-1 together
    end type variation_t

    !> The variations as pieces of work.
    type, extends(parallel_work_t) :: variations_t
        type(variation_t) :: variation(VARIATIONS)
    contains
        procedure :: do_one => do_variation
    end type variations_t

contains

    !> All variations. Fails when a case cannot be propagated.
    subroutine study_window_sensitivity(threads, variation, error)
        integer, intent(in) :: threads              !! How many to use
        type(variation_t), intent(out) :: variation(VARIATIONS)
        type(error_t), allocatable, intent(out) :: error

        type(variations_t) :: work

        work%variation(1) = variation_t('as it is')
        work%variation(2) = variation_t('rods of 1 A m^2', amplitude=1/30.0_dp)
        work%variation(3) = variation_t('rods of 10 A m^2', amplitude=10/30.0_dp)
        work%variation(4) = variation_t('rods of 28 A m^2', amplitude=28/30.0_dp)
        work%variation(5) = variation_t('rods of 33 A m^2', amplitude=33/30.0_dp)
        work%variation(6) = variation_t('0.05 Hz', frequency=0.5_dp)
        work%variation(7) = variation_t('0.11 Hz', frequency=1.1_dp)
        work%variation(8) = variation_t('both rods reversed', first_rod=-1.0_dp, second_rod=-1.0_dp)
        work%variation(9) = variation_t('z rod reversed', second_rod=-1.0_dp)
        work%variation(10) = variation_t('y rod alone', second_rod=0.0_dp)
        work%variation(11) = variation_t('z rod alone', first_rod=0.0_dp)
        work%variation(12) = variation_t('d reversed', offset=-[1.0_dp, 1.0_dp, 1.0_dp])
        work%variation(13) = variation_t('d longer by a tenth', offset=1.1_dp*[1.0_dp, 1.0_dp, 1.0_dp])
        work%variation(14) = variation_t('d_z alone longer by a tenth', offset=[1.0_dp, 1.0_dp, 1.1_dp])
        call run_parallel(work, VARIATIONS, threads, error)
        variation = work%variation
    end subroutine study_window_sensitivity

    subroutine do_variation(self, i, error)
        class(variations_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(case_t) :: case
        type(verification_t) :: verification
        type(window_check_t), allocatable :: checks(:)
        integer :: s

        allocate (checks(0))
        do s = 1, size(SATELLITES)
            call report_case(trim(SATELLITES(s))//'-1', case, error)
            if (allocated(error)) return
            call apply(self%variation(i), case)
            call verify_case(case, verification, error)
            if (allocated(error)) return
            checks = [checks, check_windows(trim(SATELLITES(s)), verification)]
        end do
        self%variation(i)%counts = count_windows(checks)
    end subroutine do_variation

    !> The two rods of the report's manoeuvre are its first two activations.
    pure subroutine apply(variation, case)
        type(variation_t), intent(in) :: variation
        type(case_t), intent(inout) :: case

        associate (rods => case%satellite%rods)
            rods%activations(:rods%count)%amplitude = variation%amplitude*rods%activations(:rods%count)%amplitude
            rods%activations(:rods%count)%frequency = variation%frequency*rods%activations(:rods%count)%frequency
            rods%activations(1)%amplitude = variation%first_rod*rods%activations(1)%amplitude
            rods%activations(2)%amplitude = variation%second_rod*rods%activations(2)%amplitude
        end associate
        case%satellite%offset = variation%offset*case%satellite%offset
    end subroutine apply

    !> The variations, and the windows of the attitude dynamics that each meets.
    function variations_table(variation) result(table)
        type(variation_t), intent(in) :: variation(:)
        type(data_table_t) :: table

        integer :: i

        call table%columns_of('change,attitude_windows,inside,on_ticks,by_rule,least_fill')
        do i = 1, size(variation)
            associate (c => variation(i)%counts)
                call table%add(variation(i)%name)
                call table%add(real([c%attitude, c%attitude_inside, c%attitude_on_ticks, c%attitude_automatic], dp))
                call table%add(c%attitude_fill)
            end associate
        end do
    end function variations_table
end module gracecg_studies_window_sensitivity
