!> `gracecg bound`, and what `estimate` and `montecarlo` say of `optimal`.
module test_bound_command
    use vocabulary
    use calibrations
    use gracecg_base_text, only: split
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use command_fixture
    implicit none
    private
    public :: collect_bound_command

    character(1), parameter :: LF = new_line('a')

contains

    subroutine collect_bound_command(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('csv-columns-and-values', test_csv), &
                    new_unittest('text', test_text), &
                    new_unittest('wrong-inputs', test_wrong), &
                    new_unittest('optimal-from-files', test_files), &
                    new_unittest('montecarlo-without-systematic-errors', test_montecarlo)]
    end subroutine collect_bound_command

    subroutine test_csv(error)
        type(error_type), allocatable, intent(out) :: error
        type(string_t), allocatable :: rows(:), fields(:)
        type(case_t) :: case
        type(case_bound_t) :: bound
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages
        real(dp) :: values(7)
        integer :: i

        call succeeds(error, 'bound front-3 back-1 --format csv', output, messages)
        rows = split(output, LF)
        call check(error, rows(1)%text, &
                   'case,sigma_x_mm,sigma_y_mm,sigma_z_mm,worst_sigma_mm,worst_x,worst_y,worst_z,'// &
                   'consider_x_mm,consider_y_mm,consider_z_mm')
        fields = split(rows(3)%text, ',')
        call check(error, fields(1)%text, 'back-1')
        do i = 1, 7
            read (fields(i + 1)%text, *) values(i)
        end do
        call take_case('back-1', case)
        call bound_of_case(case, estimation_options_t(), bound, failure)
        call check(error, maxval(abs(values(1:3) - 1e3_dp*bound%sigma)) < 1e-12_dp)
        call check(error, norm2(values(5:7)), 1.0_dp, thr=1e-12_dp)
        ! along the worst direction the covariance has the worst variance
        call check(error, sqrt(dot_product(values(5:7), matmul(bound%covariance, values(5:7))))*1e3_dp, values(4), &
                   thr=1e-9_dp)
    end subroutine test_csv

    subroutine test_text(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output

        call succeeds(error, 'bound front-1', output)
        call check_says(error, output, 'front-1 ... Cramer-Rao ... scale factors ... rod gain ... magnetometer bias ... '// &
                        'inertia ... unmodelled torque ... worst direction')
        call check(error, index(output, 'estimated, too') == 0)
        call edit_case(error, 'front-1', 'scaled.nml', 'estimate_scale_factors = .false.', 'estimate_scale_factors = .true.')
        call prints(error, 'bound '//FOLDER//'scaled.nml', &
                    'a-priori sigmas of scale factors, which are estimated, too ... adds by rod gain')
    end subroutine test_text

    subroutine test_wrong(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, 'bound front-9', STATUS_FAILED, 'no case "front-9"')
        call edit_case(error, 'front-1', 'negative.nml', 'noise_level = 1e-20, 1e-18', 'noise_level = -1e-20, 1e-18')
        call refused(error, 'bound '//FOLDER//'negative.nml', STATUS_FAILED, 'negative.nml ... noise_level ... -1')
        call refused(error, 'montecarlo --without sunlight', STATUS_MISUSED, '--without ... sunlight ... scale-factors')
    end subroutine test_wrong

    subroutine test_files(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, messages

        call succeeds(error, 'simulate front-1 --out '//FOLDER//'optimal-run')
        call succeeds(error, 'estimate '//FOLDER//'optimal-run --algorithm optimal', output, messages)
        call check_fails(error, output, 'optimal ... variance factor ... noise level ... torque_x ... wave_sin')
        call check_fails(error, messages, 'a wave of period')
    end subroutine test_files

    subroutine test_montecarlo(error)
        type(error_type), allocatable, intent(out) :: error

        call prints(error, 'montecarlo --cases front-3 --algorithms optimal --runs 5 --without systematic', &
                    'switched off here: systematic ... own covariances')
    end subroutine test_montecarlo
end module test_bound_command
