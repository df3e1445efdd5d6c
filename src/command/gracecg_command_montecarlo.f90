!> gracecg montecarlo: Tables 6.1 and 6.2 of CSR-TM-00-01, ours beside the published values and the
!> theoretical prediction.
module gracecg_command_montecarlo
    use omp_lib, only: omp_get_num_procs
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t
    use gracecg_version, only: VERSION
    use gracecg_text, only: string_t, integer_text, join, real_text
    use gracecg_file, only: output_file_t
    use gracecg_csv, only: csv_writer_t
    use gracecg_observation_set, only: observation_set_t
    use gracecg_calibration_solution, only: calibration_solution_t
    use gracecg_estimators, only: estimate_offset, ESTIMATOR_NAMES
    use gracecg_calibration_case, only: calibration_case_t
    use gracecg_case_library, only: find_case
    use gracecg_report_cases, only: REPORT_CASE_NAMES
    use gracecg_simulation, only: simulator_t, new_simulator, observe
    use gracecg_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of, &
        prediction_t, predict_errors
    use gracecg_published_rms, only: published_rms, is_misprint, allowed_by_fifteen_runs
    use gracecg_arguments, only: arguments_t
    use gracecg_console, only: console_t
    implicit none
    private
    public :: declare_montecarlo, run_montecarlo

    real(dp), parameter :: MILLIMETRE = 1e-3_dp     !! m
    character(1), parameter :: AXES(3) = ['x', 'y', 'z']
    integer, parameter :: REPORT_RUNS = 15          !! Of every entry of the published tables

    !> What the user asks for.
    type :: plan_t
        type(string_t), allocatable :: cases(:), algorithms(:)
        integer :: runs = REPORT_RUNS, seed = 1, threads = 1
        character(:), allocatable :: table_file, runs_file      !! Empty: none
    end type plan_t

    !> One case with one algorithm, in mm.
    type :: entry_t
        character(:), allocatable :: case, algorithm
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        real(dp) :: predicted(3) = 0
        real(dp) :: published(3) = 0        !! 0: none
    end type entry_t

contains

    subroutine declare_montecarlo(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('montecarlo', '', 0, 0, &
                                'Simulates and estimates many calibrations of each case and prints the RMS '// &
                                'error of the CG offset in the layout of Tables 6.1 and 6.2 of '// &
                                'CSR-TM-00-01, beside the published values and the prediction of a '// &
                                'covariance analysis.', &
                                'gracecg montecarlo --cases front-3,back-3 --algorithms assest-fde --runs 100')
        call arguments%add_option('--cases', 'LIST', 'names or namelist files, separated by commas (default: '// &
                                  'the six built-in cases)')
        call arguments%add_option('--algorithms', 'LIST', 'of '//join(ESTIMATOR_NAMES, ', ')//' (default: all)')
        call arguments%add_option('--runs', 'N', 'of each case (default 15, as in the report)')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine); '// &
                                  'the numbers do not depend on it')
        call arguments%add_option('--out', 'FILE', 'CSV file for the statistics')
        call arguments%add_option('--runs-out', 'FILE', 'CSV file for the estimate of every run')
    end subroutine declare_montecarlo

    subroutine run_montecarlo(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(plan_t) :: plan
        type(simulator_t) :: simulator
        type(entry_t), allocatable :: entries(:)
        integer :: i, a

        call read_plan(arguments, plan, misuse)
        if (allocated(misuse)) return
        allocate (entries(size(plan%cases)*size(plan%algorithms)))
        do i = 1, size(plan%cases)
            call prepare_case(plan%cases(i)%text, simulator, error)
            if (allocated(error)) return
            if (i == 1) call show_heading(plan, console)
            call show_one_calibration(simulator, plan, console, error)
            if (allocated(error)) return
            do a = 1, size(plan%algorithms)
                call console%progress('montecarlo: '//trim(simulator%case%setup%name)//', '// &
                                      plan%algorithms(a)%text//', '//integer_text(plan%runs)//' runs')
                call fill_entry(simulator, plan%algorithms(a)%text, plan, &
                                entries((i - 1)*size(plan%algorithms) + a), error)
                if (allocated(error)) return
            end do
        end do
        call show_tables(entries, plan, console)
        if (plan%table_file /= '') call write_table(entries, plan, error)
        if (allocated(error)) return
        if (plan%runs_file /= '') call write_runs(entries, plan, error)
    end subroutine run_montecarlo

    subroutine read_plan(arguments, plan, misuse)
        type(arguments_t), intent(in) :: arguments
        type(plan_t), intent(out) :: plan
        type(error_t), allocatable, intent(out) :: misuse

        integer, parameter :: MOST_RUNS = 10000000, MOST_THREADS = 1024

        call arguments%get('--cases', plan%cases, misuse, default=join(REPORT_CASE_NAMES, ','))
        if (.not. allocated(misuse)) call arguments%get('--algorithms', plan%algorithms, misuse, &
                                                        default=join(ESTIMATOR_NAMES, ','), &
                                                        choices=ESTIMATOR_NAMES)
        if (.not. allocated(misuse)) call arguments%get('--runs', plan%runs, misuse, default=REPORT_RUNS, &
                                                        low=1, high=MOST_RUNS)
        if (.not. allocated(misuse)) call arguments%get('--seed', plan%seed, misuse, default=1)
        if (.not. allocated(misuse)) call arguments%get('--threads', plan%threads, misuse, &
                                                        default=omp_get_num_procs(), low=1, high=MOST_THREADS)
        if (.not. allocated(misuse)) call arguments%get('--out', plan%table_file, misuse, default='')
        if (.not. allocated(misuse)) call arguments%get('--runs-out', plan%runs_file, misuse, default='')
    end subroutine read_plan

    subroutine prepare_case(name, simulator, error)
        character(*), intent(in) :: name
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable, intent(out) :: error

        type(calibration_case_t) :: case

        call find_case(name, case, error)
        if (.not. allocated(error)) call new_simulator(case, simulator, error)
    end subroutine prepare_case

    subroutine fill_entry(simulator, algorithm, plan, entry, error)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm
        type(plan_t), intent(in) :: plan
        type(entry_t), intent(inout) :: entry
        type(error_t), allocatable, intent(out) :: error

        type(prediction_t) :: prediction
        integer :: i

        entry%case = trim(simulator%case%setup%name)
        entry%algorithm = algorithm
        call predict_errors(simulator, algorithm, prediction, error)
        if (allocated(error)) return
        call run_monte_carlo(simulator, algorithm, plan%seed, [(i, i=1, plan%runs)], plan%threads, &
                             entry%results, error)
        if (allocated(error)) return
        entry%statistics = statistics_of(entry%results%offset/MILLIMETRE, simulator%case%offset/MILLIMETRE)
        entry%predicted = prediction%rms/MILLIMETRE
        entry%published = published_rms(entry%case, algorithm)
    end subroutine fill_entry

    subroutine show_heading(plan, console)
        type(plan_t), intent(in) :: plan
        type(console_t), intent(inout) :: console

        call console%line('CG offset d (centre of mass to proof mass, body axes, mm) of one simulated '// &
                          'calibration: '//plan%algorithms(1)%text//', run 1, seed '//integer_text(plan%seed))
        call console%line('case          d_x true  estimate  sigma     d_y true  estimate  sigma     '// &
                          'd_z true  estimate  sigma')
    end subroutine show_heading

    !> The first run of a case, as an operator would see it.
    subroutine show_one_calibration(simulator, plan, console, error)
        type(simulator_t), intent(in) :: simulator
        type(plan_t), intent(in) :: plan
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(calibration_solution_t) :: solution
        character(120) :: row
        integer :: i

        call observe(simulator, plan%seed, 1, observations, error)
        if (allocated(error)) return
        call estimate_offset(plan%algorithms(1)%text, observations, solution, error)
        if (allocated(error)) return
        write (row, '(a, t13, 3(f10.4, f10.4, f8.4, :, 2x))') trim(simulator%case%setup%name), &
            (simulator%case%offset(i)/MILLIMETRE, solution%offset(i)/MILLIMETRE, &
             sqrt(solution%covariance(i, i))/MILLIMETRE, i=1, 3)
        call console%line(trim(row))
    end subroutine show_one_calibration

    !> RMS by case and axis; a row of ours, one of the report and one of theory.
    subroutine show_tables(entries, plan, console)
        type(entry_t), intent(in) :: entries(:)
        type(plan_t), intent(in) :: plan
        type(console_t), intent(inout) :: console

        character(160) :: row
        integer :: i, axis, n, first

        n = size(plan%algorithms)
        call console%line('')
        call console%line('RMS error of the CG offset, mm: '//integer_text(plan%runs)//' runs here, '// &
                          integer_text(REPORT_RUNS)//' in CSR-TM-00-01 (Tables 6.1 and 6.2), and theory')
        if (n > 1) call console%line('(here all algorithms work on the same observations; in the report '// &
                                     'each had its own)')
        write (row, '(a, t27, *(a12))') 'case      axis', (plan%algorithms(i)%text, i=1, n)
        call console%line(trim(row))
        do i = 1, size(plan%cases)
            first = (i - 1)*n
            do axis = 1, 3
                write (row, '(a, t11, a, t16, a, t27, *(f12.5))') entries(first + 1)%case, AXES(axis), &
                    'here', entries(first + 1:first + n)%statistics%rms(axis)
                call console%line(trim(row))
                if (any(entries(first + 1:first + n)%published(axis) > 0)) then
                    write (row, '(t16, a, t27, *(f12.5))') 'report', &
                        entries(first + 1:first + n)%published(axis)
                    call console%line(trim(row))
                end if
                write (row, '(t16, a, t27, *(f12.5))') 'theory', entries(first + 1:first + n)%predicted(axis)
                call console%line(trim(row))
            end do
        end do
        call show_verdict(entries, plan, console)
    end subroutine show_tables

    !> How ours, the report's and theory agree.
    subroutine show_verdict(entries, plan, console)
        type(entry_t), intent(in) :: entries(:)
        type(plan_t), intent(in) :: plan
        type(console_t), intent(inout) :: console

        integer :: i, published, allowed, not_converged
        logical :: misprint
        real(dp) :: worst

        published = 0
        allowed = 0
        not_converged = 0
        worst = 0
        misprint = .false.
        do i = 1, size(entries)
            associate (entry => entries(i))
                published = published + count(entry%published > 0)
                allowed = allowed + count(entry%published > 0 .and. &
                                          allowed_by_fifteen_runs(entry%published, entry%predicted))
                not_converged = not_converged + count(.not. entry%results%converged)
                misprint = misprint .or. any(is_misprint(entry%published))
                worst = max(worst, maxval(abs(entry%statistics%rms/entry%predicted - 1)))
            end associate
        end do
        call console%line('')
        if (published > 0) then
            call console%line('published values that 15 runs allow if theory is right (95 %): '// &
                              integer_text(allowed)//' of '//integer_text(published))
        end if
        if (misprint) then
            call console%line('front-1, ascrest, z is printed 0.01112 in the report: taken as 0.1112')
        end if
        call console%line('largest difference of an RMS here from theory: '//percent(worst)// &
                          '; one sigma of '//integer_text(plan%runs)//' runs: '// &
                          percent(1/sqrt(2.0_dp*plan%runs)))
        if (not_converged > 0) then
            call console%message('warning: '//integer_text(not_converged)//' runs did not converge')
        end if
    end subroutine show_verdict

    function percent(part) result(text)
        real(dp), intent(in) :: part
        character(:), allocatable :: text

        character(12) :: digits

        write (digits, '(f10.1)') 100*part
        text = trim(adjustl(digits))//' %'
    end function percent

    function settings_comments(plan) result(comments)
        type(plan_t), intent(in) :: plan
        character(80) :: comments(2)

        comments(1) = 'gracecg '//VERSION//' montecarlo'
        comments(2) = 'seed '//integer_text(plan%seed)//', runs 1 to '//integer_text(plan%runs)
    end function settings_comments

    subroutine write_table(entries, plan, error)
        type(entry_t), intent(in) :: entries(:)
        type(plan_t), intent(in) :: plan
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(80) :: comments(2)
        character(:), allocatable :: published
        integer :: i, axis

        call file%open(plan%table_file, error)
        if (allocated(error)) return
        comments = settings_comments(plan)
        call file%line('# '//trim(comments(1)))
        call file%line('# '//trim(comments(2)))
        call file%line('case,algorithm,axis,runs,rms_mm,mean_error_mm,std_mm,predicted_mm,published_mm')
        do i = 1, size(entries)
            associate (entry => entries(i))
                do axis = 1, 3
                    published = ''
                    if (entry%published(axis) > 0) published = real_text(entry%published(axis))
                    call file%line(entry%case//','//entry%algorithm//','//AXES(axis)//','// &
                                   integer_text(size(entry%results%run))//','// &
                                   real_text(entry%statistics%rms(axis))//','// &
                                   real_text(entry%statistics%mean(axis))//','// &
                                   real_text(entry%statistics%deviation(axis))//','// &
                                   real_text(entry%predicted(axis))//','//published)
                end do
            end associate
        end do
        call file%commit(error)
    end subroutine write_table

    subroutine write_runs(entries, plan, error)
        type(entry_t), intent(in) :: entries(:)
        type(plan_t), intent(in) :: plan
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(64) :: labels(2)
        integer :: i, k

        call file%open(plan%runs_file, 'case,algorithm,run,dx_mm,dy_mm,dz_mm,converged', &
                       settings_comments(plan), error)
        if (allocated(error)) return
        do i = 1, size(entries)
            associate (entry => entries(i))
                labels = [character(64) :: entry%case, entry%algorithm]
                do k = 1, size(entry%results%run)
                    call file%row([real(entry%results%run(k), dp), entry%results%offset(:, k)/MILLIMETRE, &
                                   merge(1.0_dp, 0.0_dp, entry%results%converged(k))], labels)
                end do
            end associate
        end do
        call file%commit(error)
    end subroutine write_runs
end module gracecg_command_montecarlo
